"""The evidence of a run: schema, writer, reader."""
