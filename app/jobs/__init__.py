"""Work outside the server's process: a durable queue, the processes that work on it, and their supervisor."""
