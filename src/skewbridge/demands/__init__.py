"""The demands table: columns, validity of rows, and files."""
