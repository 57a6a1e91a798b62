"""The paper's studies and closed forms against independent references."""
