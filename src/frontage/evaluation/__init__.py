"""Results against truth: matching, errors, intervals."""
