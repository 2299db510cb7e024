// @ts-check
/**
 * The content of an export, and the input of its dialog. Pure.
 *
 * @typedef {import('../types.js').TrackColumns} TrackColumns
 * @typedef {import('../types.js').TrackDoc} TrackDoc
 * @typedef {import('./join.js').Span} Span
 */
import { NO_CLASS, verdictOf } from './documents.js';
import { isCorrected } from './corrected.js';
import { labelOf } from './effective.js';
import { countFrames, shownSpans } from './shown_spans.js';

/** Accepted and edited tracks; false positives are exported separately, because they are no signs. */
export const DEFAULT_STATES = /** @type {readonly string[]} */ (['edited', 'accepted', 'rejected']);

/**
 * @typedef {object} ExportChoice   the choices that the export dialog remembers
 * @property {string} format
 * @property {'none'|'annotated'|'all'} pictures
 * @property {string[]} states
 * @property {string[]|null} labels   keys; null: all
 * @property {'leave-out'|'ignore'|'class'} not_in_set   how signs without a label of the set are exported
 * @property {'all'|'used'} class_map  labels that the files declare
 * @property {boolean} balance
 * @property {string} min_side         as typed
 * @property {boolean} split
 * @property {[string, string, string]} shares   train, val, test, as typed
 * @property {'sign'|'video'} split_by
 * @property {string} seed
 * @property {string} thin_px
 * @property {Record<string, Record<string, string>>} switches   by format
 */

/** @type {ExportChoice} */
export const DEFAULT_CHOICE = {
  format: 'cvat-video',
  pictures: 'none',
  states: [...DEFAULT_STATES],
  labels: null,
  not_in_set: 'leave-out',
  class_map: 'all',
  balance: false,
  min_side: '',
  split: false,
  shares: ['80', '20', '0'],
  split_by: 'sign',
  seed: '0',
  thin_px: '0.5',
  switches: {},
};

/** The remembered choice. Invalid fields get their default. @param {string|null} text @returns {ExportChoice} */
export function restoreChoice(text) {
  /** @type {any} */
  let stored = null;
  try {
    stored = JSON.parse(text ?? 'null');
  } catch {
    // Not valid JSON: use the defaults.
  }
  if (stored === null || typeof stored !== 'object') return { ...DEFAULT_CHOICE };
  /** @param {unknown} value @param {(item: unknown) => boolean} isValid */
  const isListOf = (value, isValid) => Array.isArray(value) && value.every(isValid);
  const isText = (/** @type {unknown} */ item) => typeof item === 'string';
  return {
    format: isText(stored.format) ? stored.format : DEFAULT_CHOICE.format,
    pictures: ['none', 'annotated', 'all'].includes(stored.pictures) ? stored.pictures : 'none',
    // a choice from before label sets does not name edited tracks; they were exported together with open ones
    states: 'labels' in stored && isListOf(stored.states, isText) && stored.states.length ? stored.states : [...DEFAULT_STATES],
    labels: isListOf(stored.labels, isText) ? stored.labels : null,
    not_in_set: ['ignore', 'class'].includes(stored.not_in_set) ? stored.not_in_set : 'leave-out',
    class_map: stored.class_map === 'used' ? 'used' : 'all',
    balance: stored.balance === true,
    min_side: isText(stored.min_side) ? stored.min_side : '',
    split: stored.split === true,
    shares: isListOf(stored.shares, isText) && stored.shares.length === 3 ? stored.shares : [...DEFAULT_CHOICE.shares],
    split_by: stored.split_by === 'video' ? 'video' : 'sign',
    seed: isText(stored.seed) ? stored.seed : '0',
    thin_px: isText(stored.thin_px) ? stored.thin_px : '0.5',
    switches: stored.switches !== null && typeof stored.switches === 'object' && !Array.isArray(stored.switches) ? stored.switches : {},
  };
}

/**
 * Parse a number that the user typed.
 *
 * @param {string} text
 * @param {{name: string, low: number, high: number, whole?: boolean, empty?: number|null}} rule   empty: the value of an empty field
 * @returns {{value: number|null}|{error: string}}
 */
export function parseNumber(text, { name, low, high, whole = false, empty }) {
  const trimmed = text.trim();
  if (trimmed === '' && empty !== undefined) return { value: empty };
  const value = /^[+-]?(\d+\.?\d*|\.\d+)$/.test(trimmed) ? Number(trimmed) : NaN;
  if (Number.isNaN(value) || (whole && !Number.isInteger(value)) || value < low || value > high) {
    return { error: `${name} must be a ${whole ? 'whole number' : 'number'} from ${low} to ${high}.` };
  }
  return { value };
}

/**
 * Parse the first and the last frame that the user typed.
 *
 * @param {string} firstText
 * @param {string} lastText
 * @param {{low: number, high: number}} limits   inclusive
 * @returns {{first: number, stop: number}|{error: string}}
 */
export function parseFrames(firstText, lastText, limits) {
  const first = parseNumber(firstText, { name: 'The first frame', ...limits, whole: true });
  if ('error' in first) return first;
  const last = parseNumber(lastText, { name: 'The last frame', ...limits, whole: true });
  if ('error' in last) return last;
  const range = { first: Number(first.value), stop: Number(last.value) + 1 };
  return range.stop > range.first ? range : { error: 'The last frame comes before the first.' };
}

/**
 * @typedef {object} ExportCounts   the amount that is exported
 * @property {number} tracks
 * @property {number} boxes       upper bound
 * @property {number} rejected    false positives, which are exported separately
 * @property {number} open        tracks that are not exported because nobody has judged them
 * @property {number} unlabelled  tracks that are not exported because they have no label of the set
 * @property {Map<number, number>} byLabel   exported tracks, by the id of their label
 */

/**
 * Estimate what an export contains: the exact number of tracks and an upper bound on boxes. Rejected tracks are counted
 * separately, because they are no signs.
 *
 * @param {TrackColumns} tracks
 * @param {readonly TrackDoc[]} docs
 * @param {{states: readonly string[], labels: ReadonlySet<number>|null, notInSet: string, first: number, last: number}} rule   labels: ids; last: inclusive
 * @param {(id: number) => number} resolveLabel   maps the id of a merged label to the label that replaces it
 * @returns {ExportCounts}
 */
export function countExported(tracks, docs, { states, labels, notInSet, first, last }, resolveLabel = (id) => id) {
  const at = new Map(tracks.id.map((id, column) => [id, column]));
  const touched = new Set(docs.map(({ key }) => key));
  /** @type {ExportCounts} */
  const total = { tracks: 0, boxes: 0, rejected: 0, open: 0, unlabelled: 0, byLabel: new Map() };

  /** @param {string} state @param {number|null} class_id @param {readonly Span[]} runs @param {number} share   share of their frames that have a box */
  function add(state, class_id, runs, share) {
    const boxes = countFrames(runs, first, last);
    if (boxes === 0) return;
    if (!states.includes(state) && !(state === 'edited' && states.includes('open'))) {
      if (state === 'open' || state === 'edited') total.open += 1;
      return;
    }
    const label = resolveLabel(class_id ?? NO_CLASS);
    if (state === 'rejected') {
      if (labels === null || labels.has(label)) total.rejected += 1;
      return;
    }
    if (label === NO_CLASS ? notInSet === 'leave-out' : labels !== null && !labels.has(label)) {
      if (label === NO_CLASS) total.unlabelled += 1;
      return;
    }
    total.tracks += 1;
    total.boxes += Math.round(boxes * share);
    total.byLabel.set(label, (total.byLabel.get(label) ?? 0) + 1);
  }

  tracks.id.forEach((id, column) => {
    if (touched.has(`m${id}`)) return;
    const [from, to] = [tracks.first[column], tracks.last[column]];
    add('open', tracks.class_id[column], [[from, to]], tracks.frames[column] / (to - from + 1));
  });
  for (const doc of docs) {
    const runs = shownSpans(doc, (id) => tracks.last[at.get(id) ?? -1] ?? null);
    const verdict = verdictOf(doc);
    const edited = verdict === 'open' && (isCorrected(doc, tracks) || doc.attributes !== undefined);
    add(
      edited ? 'edited' : verdict,
      labelOf(doc, (id) => tracks.class_id[at.get(id) ?? -1] ?? null),
      runs,
      1,
    );
  }
  return total;
}

/**
 * The switches of imports that a refusal names, such as `size=scale`.
 *
 * @param {string} message
 * @param {readonly Pick<import('../types.js').Format, 'import_switches'>[]} formats
 * @returns {string[]} names of the switches
 */
export function namedSwitches(message, formats) {
  const names = new Set(formats.flatMap(({ import_switches }) => import_switches.map(({ name }) => name)));
  return [...names].filter((name) => message.includes(` ${name}=`));
}

const VIDEO_EXTENSIONS =
  'mp4 m4v mov 3gp mkv webm avi ts m2ts mts m2t mpg mpeg vob flv wmv asf h264 264 avc h265 265 hevc gif apng webp'.split(' ');
/** Video files for a file dialog. Includes endings, because browsers do not know all types. */
export const VIDEO_FILES = ['video/*', ...VIDEO_EXTENSIONS.map((ending) => `.${ending}`)].join();

/** Whether a file is a video, by type or name; other files are datasets. @param {{name: string, type?: string}} file */
export const isVideoFile = (file) =>
  VIDEO_EXTENSIONS.includes(file.name.split('.').pop()?.toLowerCase() ?? '') || (file.type ?? '').startsWith('video/');
