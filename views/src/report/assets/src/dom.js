// Builds DOM nodes. Strings become text nodes: no text from the data is ever parsed as HTML.

const SVG = 'http://www.w3.org/2000/svg';

function fill(node, props, children) {
  for (const [key, value] of Object.entries(props ?? {})) {
    if (value === null || value === undefined || value === false) continue;
    if (key.startsWith('on')) node.addEventListener(key.slice(2), value);
    else if (key === 'style') for (const [name, v] of Object.entries(value)) node.style.setProperty(name, v);
    else node.setAttribute(key, value === true ? '' : String(value));
  }
  node.append(...children.flat(Infinity).filter((c) => c !== null && c !== undefined && c !== false));
  return node;
}

/** An HTML element. `on…` properties are listeners, `style` is an object, the others are attributes. */
export const h = (tag, props, ...children) => fill(document.createElement(tag), props, children);

/** An SVG element, with the same rules. */
export const svg = (tag, props, ...children) => fill(document.createElementNS(SVG, tag), props, children);

/** A 16 px icon from one path. */
export const icon = (d) => svg('svg', { viewBox: '0 0 16 16', width: 16, height: 16, 'aria-hidden': 'true', class: 'icon' }, svg('path', { d }));

/** Text in which `names` between backticks are set as code. */
export const prose = (text) => text.split(/`([^`]+)`/).map((part, i) => (i % 2 ? h('code', {}, part) : part));

/** The value of a CSS custom property of the page. */
export const cssVar = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
