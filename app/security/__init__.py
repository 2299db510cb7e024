"""Who may talk to the server, and from where."""
