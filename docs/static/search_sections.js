/* A hit in the text of a page leads to the section that holds most of the words: Sphinx knows only that they are on the page. */
/* SECTION_TEXTS, of docs/section_texts.py: page to [anchor, title, text] of each of its sections, in order, in lower case but the titles. */
Scorer.score = (result) => {
  const [page, title, anchor, , score, , kind] = result;
  if (kind === "text" && !anchor) {
    const query = new URLSearchParams(window.location.search).get("q") || "";
    const stemmer = new Stemmer();
    const words = splitQuery(query.toLowerCase()).map((word) => [word, stemmer.stemWord(word)]);
    const found = (text) => words.filter((forms) => forms.some((form) => text.includes(form))).length;
    let most = 0;
    for (const [place, heading, text] of SECTION_TEXTS[page] || []) {
      const count = found(`${heading.toLowerCase()} ${text}`) + found(heading.toLowerCase()) / (words.length + 1);
      if (count > most) {
        most = count;
        result[2] = place ? `#${place}` : "";
        result[1] = place ? `${title} > ${heading}` : title;
      }
    }
  }
  return score;
};
