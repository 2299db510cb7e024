"""Access control: who may use the server, and from where."""
