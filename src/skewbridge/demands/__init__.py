"""The demands table: columns, validity of its rows, and files."""
