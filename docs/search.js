/* Search: the scores are Sphinx's own, but that the modules and the changelog follow the pages for users. */
var Scorer = {
  score: ([docname, , , , score]) => (/^(reference\/api\/|changelog)/.test(docname) ? score - 100 : score),
  objNameMatch: 11,
  objPartialMatch: 6,
  objPrio: { 0: 15, 1: 5, 2: -5 },
  objPrioDefault: 0,
  title: 15,
  partialTitle: 7,
  term: 5,
  partialTerm: 2,
};
