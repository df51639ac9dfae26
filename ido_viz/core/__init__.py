"""What a page is and shows, without a browser: states, methods, runs, frames."""
