"""Reference solvers, closed forms and test cases of the verification studies."""
