"""The demands table: columns, completeness, suspect rows and files."""
