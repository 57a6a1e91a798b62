"""From analyses to the demands table: batch, journal, parquet, progress."""
