"""How the page is served, and who may connect."""
