"""Commands of the contact room."""

import typer


def register(app: typer.Typer) -> None:
    """Add the commands to the application."""
