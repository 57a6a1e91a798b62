"""Studies and statements of the paper, checked against closed forms and other references."""
