"""The paper's studies and statements, compared with closed forms and other references."""
