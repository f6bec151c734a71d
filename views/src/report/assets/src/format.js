// Numbers with units, as an engineer would write them: "3.1 mm", "0.02°", "120 µs".

const PREFIXES = [['M', 1e6], ['k', 1e3], ['', 1], ['m', 1e-3], ['µ', 1e-6], ['n', 1e-9], ['p', 1e-12]];
const PREFIXABLE = new Set(['m', 's', 'm/s', 'm/s²', 'm/s³', 'N', 'N m', 'W', 'J', 'Hz']);
// Units that are multiples of another one: name, base unit, factor.
const MULTIPLES = {
  us: ['s', 1e-6], 'µs': ['s', 1e-6], ns: ['s', 1e-9], ms: ['s', 1e-3],
  mm: ['m', 1e-3], cm: ['m', 1e-2], 'mm/s': ['m/s', 1e-3], '%': ['%', 1],
};
const DEGREES = 180 / Math.PI;
// Below this an SI value is rounding noise of double precision.
const NOISE = 1e-12;

/** Whether angles are shown in degrees; the other choice is radians. */
export const settings = { degrees: true };

function parse(unit) {
  let name = String(unit ?? '').trim().replace(/\^2/g, '²').replace(/\^3/g, '³').replace(/^N[·.*]?m$/, 'N m');
  if (name === '1' || name === '-') name = '';
  if (name.length > 16) name = `${name.slice(0, 15)}…`;
  const angle = /^(rad|deg|°)(.*)$/.exec(name);
  if (angle) {
    const given = angle[1] === 'rad' ? 1 : 1 / DEGREES;
    return { base: (settings.degrees ? '°' : ' rad') + angle[2], scale: given * (settings.degrees ? DEGREES : 1), prefixable: false };
  }
  const [base, scale] = MULTIPLES[name] ?? [name, 1];
  return { base: base && (base === '%' ? base : ` ${base}`), scale, prefixable: PREFIXABLE.has(base) };
}

/** True if the unit is an angle or is made from one. */
export const isAngular = (unit) => /^(rad|deg|°)/.test(String(unit ?? '').trim());

const SUPERSCRIPT = { '-': '⁻', 0: '⁰', 1: '¹', 2: '²', 3: '³', 4: '⁴', 5: '⁵', 6: '⁶', 7: '⁷', 8: '⁸', 9: '⁹' };
const power = (n) => `10${[...String(n)].map((c) => SUPERSCRIPT[c]).join('')}`;
const minus = (text) => text.replace('-', '−');

/** Three significant digits (or as many as asked), without an exponent if that stays readable; `zeros` keeps zeros at the end. */
export function number(value, digits = 3, zeros = false) {
  if (value === null || !Number.isFinite(value)) return '–';
  if (value === 0) return '0';
  const rounded = Number(value.toPrecision(digits));
  const exponent = Math.floor(Math.log10(Math.abs(rounded)));
  if (exponent < -4 || exponent > 6) {
    return minus(`${Number((rounded / 10 ** exponent).toPrecision(digits))} × ${power(exponent)}`);
  }
  const plain = rounded.toFixed(Math.max(0, digits - 1 - exponent));
  return minus(zeros ? plain : String(Number(plain)));
}

function prefixFor(size) {
  // 0.35 m reads better than 350 mm: a plain unit serves from a tenth of it.
  if (size >= 0.1 && size < 1000) return ['', 1];
  return PREFIXES.find(([, factor]) => size >= factor * 0.99999) ?? PREFIXES.at(-1);
}

/** A value with its unit; "≈ 0" for rounding noise, a dash for a missing value. */
export function quantity(value, unit, digits = 3, zeros = false) {
  if (value === null || value === undefined || !Number.isFinite(value)) return '–';
  const { base, scale, prefixable } = parse(unit);
  const v = value * scale;
  if (v === 0) return `0${base}`;
  if (Math.abs(v) < NOISE) return '≈ 0';
  if (!prefixable) return number(v, digits, zeros) + base;
  const [prefix, factor] = prefixFor(Number(Math.abs(v).toPrecision(digits)));
  return `${number(v / factor, digits, zeros)} ${prefix}${base.trim()}`;
}

/** How the y axis of a plot is scaled: data are multiplied by `factor` and carry the unit `label`. */
export function axisUnit(unit, largest) {
  const { base, scale, prefixable } = parse(unit);
  const size = Math.abs(largest) * scale;
  if (prefixable && size > NOISE) {
    const [prefix, factor] = prefixFor(size);
    return { factor: scale / factor, label: prefix + base.trim() };
  }
  if (size > 0 && (size < 1e-3 || size >= 1e6)) {
    const exponent = 3 * Math.floor(Math.log10(size) / 3);
    return { factor: scale / 10 ** exponent, label: `${power(exponent)} ${base.replace('°', 'deg').trim()}`.trim() };
  }
  return { factor: scale, label: base.replace('°', 'deg').trim() };
}

/** A point in time, with the decimals that the spacing of the samples deserves. */
export function timeText(t, decimals = 2) {
  return Number.isFinite(t) ? `${minus(t.toFixed(decimals))} s` : '–';
}

/** A share in 0..1 as a percentage; what is small but not zero does not read as zero. */
export function percent(share) {
  if (share === null || !Number.isFinite(share)) return '–';
  const p = share * 100;
  if (p > 0 && p < 0.1) return '< 0.1 %';
  if (p < 100 && p > 99.9) return '> 99.9 %';
  return `${number(p, p < 10 ? 2 : 3)} %`;
}

/** A count with thin spaces between thousands. */
export function count(value) {
  return Number.isFinite(value) ? String(Math.round(value)).replace(/\B(?=(\d{3})+$)/g, '\u202f') : '–';
}
