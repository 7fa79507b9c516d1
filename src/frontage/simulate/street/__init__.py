"""Street."""
