"""Pure maths on arrays: no project types, no files."""
