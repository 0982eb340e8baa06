"""Films of a life: `packing` makes its numbers small, `page` puts them into a page that plays them, `raster` and `video` draw frames."""
