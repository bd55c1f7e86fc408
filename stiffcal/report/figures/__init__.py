"""One picture per file; each ``draw_…`` returns a matplotlib ``Figure`` that `canvas.save_figure` writes."""
