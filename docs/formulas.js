// Sets the formulas of the site, which stand between $$ in the pages, by KaTeX.
for (const place of document.querySelectorAll(".arithmatex"))
  katex.render(place.textContent.trim().slice(2, -2), place, { displayMode: true });
