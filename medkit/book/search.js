const box = document.getElementById("search");
const found = document.getElementById("found");
box.addEventListener("input", () => {
  const words = box.value.toLowerCase().split(/\s+/).filter(Boolean);
  found.replaceChildren();
  if (!words.length) return;
  const score = (page) => {
    const title = page.title.toLowerCase(), text = page.text.toLowerCase();
    if (!words.every((word) => title.includes(word) || text.includes(word))) return 0;
    return words.reduce((sum, word) => sum + (title.includes(word) ? 20 : 0) + text.split(word).length, 0);
  };
  PAGES.map((page) => [score(page), page]).filter(([s]) => s > 0).sort((a, b) => b[0] - a[0]).slice(0, 8)
    .forEach(([, page]) => {
      const item = document.createElement("li"), link = document.createElement("a"), near = document.createElement("small");
      const at = Math.max(0, page.text.toLowerCase().indexOf(words[0]) - 40);
      link.href = page.page; link.textContent = page.title;
      near.textContent = "… " + page.text.slice(at, at + 110) + " …";
      item.append(link, near); found.append(item);
    });
});
