"""`rostether completion` (being written by the helper of the verb groups)."""
