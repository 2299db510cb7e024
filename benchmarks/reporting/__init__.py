"""Writes the report from stored results: tables, figures, sheets of cut-outs, and the comparison with the paper."""
