"""`rostether ports` (being written by the helper of the verb groups)."""
