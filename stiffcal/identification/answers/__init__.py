"""What is answered of a fit: parameters, tables, comparisons."""
