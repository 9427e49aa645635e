"""How the page and the figures look: number formats, colours, print sizes, packed arrays."""
