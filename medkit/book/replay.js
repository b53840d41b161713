// Filters of the replay page. Without this script every row is shown and the counts stay readable.
const chips = [...document.querySelectorAll("#chips .chip")];
const rows = [...document.querySelectorAll("#rows tr[data-verdict]")];
const count = document.getElementById("count");
const chosen = { verdict: new Set(), thesis: new Set() };
function refresh() {
  const fits = (row, kind) => !chosen[kind].size || chosen[kind].has(row.dataset[kind]);
  rows.forEach((row) => { row.hidden = !(fits(row, "verdict") && fits(row, "thesis")); });
  document.querySelectorAll("#rows tbody").forEach((group) => {
    group.hidden = ![...group.querySelectorAll("tr[data-verdict]")].some((row) => !row.hidden);
  });
  chips.forEach((chip) => chip.setAttribute("aria-pressed", chosen[chip.dataset.kind].has(chip.dataset.value)));
  const shown = rows.filter((row) => !row.hidden).length;
  count.textContent = shown === rows.length ? `${rows.length} rows; click a count to filter` : `${shown} of ${rows.length} rows`;
}
function toggle(chip) {
  const set = chosen[chip.dataset.kind];
  if (!set.delete(chip.dataset.value)) set.add(chip.dataset.value);
  refresh();
}
chips.forEach((chip) => {
  chip.setAttribute("role", "button");
  chip.tabIndex = 0;
  chip.addEventListener("click", () => toggle(chip));
  chip.addEventListener("keydown", (event) => {
    if (![" ", "Enter"].includes(event.key)) return;
    event.preventDefault();
    toggle(chip);
  });
});
refresh();
