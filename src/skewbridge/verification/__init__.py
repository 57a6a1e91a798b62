"""The paper's studies and statements, held against closed forms and other references."""
