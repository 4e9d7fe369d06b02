const data = JSON.parse(document.getElementById("data").textContent);
const style = name => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
/* Appends an element with a text and a class. */
const make = (name, parent, text, kind) => {
  const element = document.createElement(name);
  if (text !== undefined) element.textContent = text;
  if (kind) element.className = kind;
  parent.append(element);
  return element;
};
/* Spreads the tiles evenly over the rows that they need, now and when the width changes. */
const spreadTiles = () => {
  const tiles = document.querySelector(".tiles"), count = tiles.children.length;
  const spread = () => {
    tiles.style.gridTemplateColumns = "";
    const fit = getComputedStyle(tiles).gridTemplateColumns.split(" ").length;
    if (count > fit) tiles.style.gridTemplateColumns = `repeat(${Math.ceil(count / Math.ceil(count / fit))}, minmax(0, 1fr))`;
  };
  spread();
  addEventListener("resize", spread);
};
