"""Reading, comparing and reporting the results of berm runs (docs/output.md)."""
