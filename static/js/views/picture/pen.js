// @ts-check
/**
 * Draws lines, marks and names of a layer in its colour and dash over a dark casing.
 *
 * @typedef {import('../../types.js').Box} Box
 * @typedef {import('../../state-types.js').LayerName} LayerName
 * @typedef {import('../../model/geometry.js').Viewport} Viewport
 * @typedef {import('../../model/geometry.js').Size} Size
 */
import { scaleX, clamp, handlesOf, toScreen } from '../../model/geometry.js';
import { placeLabels } from '../../model/label_layout.js';

/** Line, dash (CSS px) and width of each layer. */
export const LAYER_STYLES = /** @type {Record<LayerName, {dash: number[], width: number}>} */ ({
  detections: { dash: [2, 2], width: 1.25 },
  predictions: { dash: [6, 4], width: 1.5 },
  search: { dash: [1, 4], width: 1.25 },
  relocalisations: { dash: [10, 3, 2, 3], width: 2 },
  results: { dash: [], width: 2 },
  corrected: { dash: [], width: 2.5 },
  truth: { dash: [3, 3], width: 1.5 },
  second: { dash: [12, 4], width: 1.5 },
  uncertainty: { dash: [2, 2], width: 1 },
  gate: { dash: [], width: 1 },
});

/** A name in the picture is truncated at this share of the width, but not below the minimum in CSS px. */
const MAX_NAME_SHARE = 0.3;
const MIN_NAME_PX = 120;

/**
 * @typedef {object} PenStyle
 * @property {(layer: LayerName) => string} colour
 * @property {string} casing
 * @property {string} font
 * @property {number} unit
 */

/** @param {HTMLElement} element @returns {PenStyle} */
export function readPenStyle(element) {
  const style = getComputedStyle(element);
  /** @param {string} name */
  const token = (name) => style.getPropertyValue(name).trim();
  const unit = (Number.parseFloat(token('--u')) || 4) / 4;
  /** @type {Partial<Record<LayerName, string>>} */ const colours = {};
  for (const layer of /** @type {LayerName[]} */ (Object.keys(LAYER_STYLES))) colours[layer] = token(`--layer-${layer}`) || '#ffffff';
  return {
    colour: (layer) => colours[layer] ?? '#ffffff',
    casing: token('--layer-casing') || 'rgb(0 0 0 / 0.65)',
    font: `600 ${Math.round(12 * unit)}px ${token('--font') || 'sans-serif'}`,
    unit,
  };
}

/** @param {CanvasRenderingContext2D} ctx @param {Viewport} view @param {Size} screen @param {PenStyle} style */
export function createPen(ctx, view, screen, style) {
  /** @type {(import('../../model/label_layout.js').WantedLabel & {layer: LayerName, text: string, weight: number})[]} */
  const labels = [];
  /** @param {Box} box @returns {Box} */
  const toScreenBox = (box) => {
    const [x1, y1] = toScreen(view, screen, box[0], box[1]);
    const [x2, y2] = toScreen(view, screen, box[2], box[3]);
    return [x1, y1, x2, y2];
  };
  /** @param {string} colour @param {number} width @param {number[]} dash @param {() => void} path */
  const stroke = (colour, width, dash, path) => {
    ctx.setLineDash([]);
    ctx.lineWidth = width + 2;
    ctx.strokeStyle = style.casing;
    ctx.beginPath();
    path();
    ctx.stroke();
    ctx.setLineDash(dash);
    ctx.lineWidth = width;
    ctx.strokeStyle = colour;
    ctx.beginPath();
    path();
    ctx.stroke();
    ctx.setLineDash([]);
  };

  const maxNameWidth = Math.max(MIN_NAME_PX * style.unit, MAX_NAME_SHARE * screen.width);

  return {
    /** Truncate a name that is too wide for the picture. @param {string} name */
    truncate(name) {
      ctx.font = style.font;
      if (ctx.measureText(name).width <= maxNameWidth) return name;
      let [fits, tooLong] = [0, name.length];
      while (tooLong - fits > 1) {
        const middle = (fits + tooLong) >> 1;
        if (ctx.measureText(`${name.slice(0, middle)}…`).width <= maxNameWidth) fits = middle;
        else tooLong = middle;
      }
      return `${name.slice(0, fits).trimEnd()}…`;
    },
    /**
     * @param {LayerName} layer
     * @param {Box} box
     * @param {string} [text]   shown when `labels` is called
     * @param {{where?: 'above'|'below', weight?: number, thin?: boolean, dashed?: boolean, guarded?: boolean}} [how]
     *   heavier labels choose their place first; guarded: labels avoid the box
     */
    box(layer, box, text, { where = 'below', weight = 0, thin = false, dashed = false, guarded = false } = {}) {
      const [x1, y1, x2, y2] = toScreenBox(box);
      const { dash, width } = LAYER_STYLES[layer];
      const scaled = (thin ? [4, 2] : dashed ? [7, 5] : dash).map((part) => part * style.unit);
      stroke(style.colour(layer), (thin ? width - 1 : width) * style.unit, scaled, () => ctx.rect(x1, y1, x2 - x1, y2 - y1));
      if (!text) return;
      ctx.font = style.font;
      labels.push({
        layer,
        text,
        weight,
        box: [x1, y1, x2, y2],
        wide: ctx.measureText(text).width + 8 * style.unit,
        high: 16 * style.unit,
        where,
        guarded,
      });
    },
    /** Draw all texts on top of all boxes. */
    labels() {
      labels.sort((a, b) => b.weight - a.weight);
      const placements = placeLabels(labels, screen);
      ctx.font = style.font;
      ctx.textBaseline = 'middle';
      labels.forEach(({ layer, wide, high, box: [x1, y1, x2, y2] }, i) => {
        const placement = placements[i];
        if (!placement?.apart) return;
        const [x, y] = [clamp((x1 + x2) / 2, placement.x, placement.x + wide), clamp((y1 + y2) / 2, placement.y, placement.y + high)];
        stroke(style.colour(layer), style.unit, [], () => {
          ctx.moveTo(x, y);
          ctx.lineTo(clamp(x, x1, x2), clamp(y, y1, y2));
        });
      });
      labels.forEach(({ layer, text, wide, high }, i) => {
        const placement = placements[i];
        if (placement === null) return;
        ctx.fillStyle = 'rgb(0 0 0 / 0.72)';
        ctx.fillRect(placement.x, placement.y, wide, high);
        ctx.fillStyle = style.colour(layer);
        ctx.fillRect(placement.x, placement.y, 3 * style.unit, high);
        ctx.fillStyle = '#ffffff';
        ctx.fillText(text, placement.x + 6 * style.unit, placement.y + high / 2 + 0.5);
      });
    },
    /** Erase the drawing inside a box. @param {Box} box */
    clear(box) {
      const [x1, y1, x2, y2] = toScreenBox(box);
      ctx.clearRect(x1, y1, x2 - x1, y2 - y1);
    },
    /** The 1-sigma box of the centre. @param {Box} box @param {[number, number, number, number]} sigma */
    innovation(box, [sx, sy]) {
      const cx = (box[0] + box[2]) / 2;
      const cy = (box[1] + box[3]) / 2;
      const [x1, y1, x2, y2] = toScreenBox([cx - sx, cy - sy, cx + sx, cy + sy]);
      stroke(style.colour('uncertainty'), style.unit, [2 * style.unit, 2 * style.unit], () => {
        ctx.rect(x1, y1, x2 - x1, y2 - y1);
      });
    },
    /** A line from the focus of expansion, drawn as a ring, to a predicted box: the path of an approaching sign. @param {[number, number]} focus @param {Box} box */
    ray(focus, box) {
      const [fx, fy] = toScreen(view, screen, ...focus);
      const [x1, y1, x2, y2] = toScreenBox(box);
      const [dx, dy] = [(x1 + x2) / 2 - fx, (y1 + y2) / 2 - fy];
      const distance = Math.hypot(dx, dy);
      const ring = 5 * style.unit;
      stroke(style.colour('predictions'), 1.5 * style.unit, [], () => ctx.arc(fx, fy, ring, 0, 2 * Math.PI));
      // it ends at the edge of the box, so that the inside stays visible
      const end =
        distance -
        Math.min((x2 - x1) / 2 / Math.max(Math.abs(dx) / distance, 1e-9), (y2 - y1) / 2 / Math.max(Math.abs(dy) / distance, 1e-9));
      if (!(end > ring)) return;
      stroke(style.colour('predictions'), style.unit, [4 * style.unit, 4 * style.unit], () => {
        ctx.moveTo(fx + (dx / distance) * ring, fy + (dy / distance) * ring);
        ctx.lineTo(fx + (dx / distance) * end, fy + (dy / distance) * end);
      });
    },
    /** @param {LayerName} layer @param {Box} box */
    cross(layer, box) {
      const [x1, y1, x2, y2] = toScreenBox(box);
      const cx = (x1 + x2) / 2;
      const cy = (y1 + y2) / 2;
      const r = 4 * style.unit;
      stroke(style.colour(layer), 1.5 * style.unit, [], () => {
        ctx.moveTo(cx - r, cy - r);
        ctx.lineTo(cx + r, cy + r);
        ctx.moveTo(cx + r, cy - r);
        ctx.lineTo(cx - r, cy + r);
      });
    },
    /** Mark a chosen box by its corners. @param {LayerName} layer @param {Box} box */
    corners(layer, box) {
      const [x1, y1, x2, y2] = toScreenBox(box);
      const armLength = Math.min(10 * style.unit, (x2 - x1) / 3, (y2 - y1) / 3);
      stroke(style.colour(layer), 3 * style.unit, [], () => {
        for (const [x, y, dx, dy] of [
          [x1, y1, 1, 1],
          [x2, y1, -1, 1],
          [x2, y2, -1, -1],
          [x1, y2, 1, -1],
        ]) {
          ctx.moveTo(x + dx * armLength, y);
          ctx.lineTo(x, y);
          ctx.lineTo(x, y + dy * armLength);
        }
      });
    },
    /** Mark a key frame. @param {LayerName} layer @param {Box} box */
    diamond(layer, box) {
      const [x1, y1] = toScreenBox(box);
      const r = 5 * style.unit;
      ctx.beginPath();
      ctx.moveTo(x1, y1 - r);
      ctx.lineTo(x1 + r, y1);
      ctx.lineTo(x1, y1 + r);
      ctx.lineTo(x1 - r, y1);
      ctx.closePath();
      ctx.fillStyle = style.colour(layer);
      ctx.fill();
      ctx.lineWidth = 1;
      ctx.strokeStyle = style.casing;
      ctx.stroke();
    },
    /** Mark a box for a merge by a frame around it. @param {Box} box */
    mark(box) {
      const [x1, y1, x2, y2] = toScreenBox(box);
      const gap = 4 * style.unit;
      stroke('rgb(240 228 66)', 3 * style.unit, [], () => ctx.rect(x1 - gap, y1 - gap, x2 - x1 + 2 * gap, y2 - y1 + 2 * gap));
    },
    /** @param {LayerName} layer @param {Box} box */
    handles(layer, box) {
      // on a small box the handles shrink and only the corners are left, so that the sign stays visible
      const side = Math.min((box[2] - box[0]) * scaleX(view), (box[3] - box[1]) * view.zoom);
      const r = Math.min(3.5, Math.max(1.5, side / 12)) * style.unit;
      for (const [name, px, py] of handlesOf(box)) {
        if (name.length === 1 && side < 40 * style.unit) continue;
        const [x, y] = toScreen(view, screen, px, py);
        ctx.fillStyle = '#ffffff';
        ctx.fillRect(x - r, y - r, 2 * r, 2 * r);
        ctx.lineWidth = 1.5 * style.unit;
        ctx.strokeStyle = style.colour(layer);
        ctx.strokeRect(x - r, y - r, 2 * r, 2 * r);
      }
    },
  };
}
