"""The review tool: a FastAPI server over the engine's evidence, and the browser page in ``static/``."""
