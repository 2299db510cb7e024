// @ts-check
/** Colours and textures of the canvases, read from the page's CSS tokens, which define both themes. */

/** Names by source: 0 detected, 1 predicted, 2 relocalised, 3 corrected. */
export const SOURCES = /** @type {const} */ (['detected', 'predicted', 'relocalised', 'corrected']);

/**
 * @typedef {object} Palette
 * @property {number} unit       CSS px per design px (larger on 4K screens)
 * @property {number} ratio      device px per CSS px
 * @property {string} font
 * @property {string} smallFont
 * @property {(string|CanvasPattern)[]} source   fill by source
 * @property {string[]} sourceColour
 * @property {string[]} series
 * @property {Record<'surface'|'surface2'|'line'|'lineStrong'|'text'|'text2'|'text3'|'accent'|'selected'|'good'|'bad'|'warn'|'grid'|'plot'|'heat', string>} colour
 */

/**
 * @param {HTMLElement} element   in the page
 * @returns {Palette}
 */
export function readPalette(element) {
  const style = getComputedStyle(element);
  /** @param {string} name */
  const token = (name) => style.getPropertyValue(name).trim();
  const unit = (Number.parseFloat(token('--u')) || 4) / 4;
  const family = token('--font') || 'sans-serif';
  const size = Number.parseFloat(getComputedStyle(document.documentElement).fontSize) || 13;
  const ratio = globalThis.devicePixelRatio || 1;
  const sourceColour = SOURCES.map((name) => token(`--source-${name}`) || '#888888');
  return {
    unit,
    ratio,
    font: `500 ${Math.round(size * 0.9)}px ${family}`,
    smallFont: `400 ${Math.round(size * 0.85)}px ${family}`,
    sourceColour,
    source: sourceColour.map((colour, i) => texture(i, colour, unit * ratio) ?? colour),
    series: [1, 2, 3, 4, 5, 6].map((i) => token(`--series-${i}`) || '#888888'),
    colour: {
      surface: token('--surface'),
      surface2: token('--surface-2'),
      line: token('--line'),
      lineStrong: token('--line-strong'),
      text: token('--text-colour'),
      text2: token('--text-2'),
      text3: token('--text-3'),
      accent: token('--accent'),
      selected: token('--selected'),
      good: token('--good'),
      bad: token('--bad'),
      warn: token('--warn'),
      grid: token('--chart-grid'),
      plot: token('--series-line'),
      heat: `rgb(${token('--heat') || '0 82 158'})`,
    },
  };
}

/**
 * The texture of a source: detected plain, predicted falling stripes, relocalised dots, corrected rising stripes.
 *
 * @param {number} source
 * @param {string} colour
 * @param {number} scale    device px per design px
 * @returns {CanvasPattern|null} null: plain
 */
function texture(source, colour, scale) {
  if (source === 0) return null;
  const side = Math.max(4, Math.round(6 * scale));
  const tile = document.createElement('canvas');
  tile.width = tile.height = side;
  const ctx = tile.getContext('2d');
  if (ctx === null) return null;
  ctx.fillStyle = colour;
  ctx.fillRect(0, 0, side, side);
  ctx.fillStyle = ctx.strokeStyle = 'rgb(0 0 0 / 0.42)';
  ctx.lineWidth = Math.max(1, 1.3 * scale);
  if (source === 2) {
    ctx.beginPath();
    ctx.arc(side / 2, side / 2, side * 0.2, 0, 2 * Math.PI);
    ctx.fill();
  } else {
    ctx.beginPath();
    for (let shift = -side; shift <= side; shift += side) {
      ctx.moveTo(shift - 1, source === 1 ? -1 : side + 1);
      ctx.lineTo(shift + side + 1, source === 1 ? side + 1 : -1);
    }
    ctx.stroke();
  }
  return ctx.createPattern(tile, 'repeat');
}

/**
 * A canvas in device px, cleared and scaled to CSS px.
 *
 * @param {HTMLCanvasElement} canvas
 * @param {number} width    CSS px
 * @param {number} height
 * @param {number} ratio
 * @returns {CanvasRenderingContext2D|null} null: the canvas has no area
 */
export function prepareCanvas(canvas, width, height, ratio) {
  const w = Math.round(width * ratio);
  const h = Math.round(height * ratio);
  if (canvas.width !== w || canvas.height !== h) {
    canvas.width = w;
    canvas.height = h;
    canvas.style.setProperty('width', `${width}px`);
    canvas.style.setProperty('height', `${height}px`);
  }
  const ctx = canvas.getContext('2d');
  if (ctx === null || w === 0 || h === 0) return null;
  ctx.setTransform(ratio, 0, 0, ratio, 0, 0);
  ctx.clearRect(0, 0, width, height);
  return ctx;
}
