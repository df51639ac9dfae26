"""One's own cloud: from a file to a shape of the page, trained, kept, judged and registered to."""
