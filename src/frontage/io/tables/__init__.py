"""Tables for users: the same rows as CSV, GeoPackage, GeoParquet, a workbook, or a data frame."""
