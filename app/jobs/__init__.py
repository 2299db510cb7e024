"""Work outside the server's process: a durable queue, the processes that empty it, and who watches them."""
