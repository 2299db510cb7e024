// @ts-check
/**
 * The search across videos: its filters as an address, and the selection of tracks. Pure.
 *
 * The names of the filters are those of `GET /api/search`, so that an address of the page is also a query to the server.
 *
 * @typedef {import('../types.js').FoundTrack} FoundTrack
 *
 * @typedef {object} SearchFilters
 * @property {string[]} label
 * @property {string[]} state
 * @property {string} uncertainty_min   0..1, as text; empty: any; other limits likewise
 * @property {string} uncertainty_max
 * @property {string} size_min          px
 * @property {string} size_max
 * @property {string[]} attribute
 * @property {string[]} author
 * @property {string} since
 * @property {string} until
 * @property {string} text
 * @property {string[]} tag
 * @property {string} video
 * @property {string} runs              `current` or `all`
 * @property {string} sort              `uncertainty`, `size` or `edited`
 * @property {string} order             `desc` or `asc`
 */
import { listNames } from './track_name.js';

/** @type {Readonly<SearchFilters>} */
export const NO_SEARCH = Object.freeze({
  label: [],
  state: [],
  uncertainty_min: '',
  uncertainty_max: '',
  size_min: '',
  size_max: '',
  attribute: [],
  author: [],
  since: '',
  until: '',
  text: '',
  tag: [],
  video: '',
  runs: 'current',
  sort: 'uncertainty',
  order: 'desc',
});

/**
 * The filters of an address; unknown ones are ignored.
 *
 * @param {string} query   the part after `?`
 * @returns {SearchFilters}
 */
export function parseSearch(query) {
  const pairs = query.split('&').map((pair) => {
    const [key, ...value] = pair.split('=');
    return [decode(key), decode(value.join('='))];
  });
  /** @type {Record<string, string|string[]>} */
  const found = {};
  for (const [name, defaultValue] of Object.entries(NO_SEARCH)) {
    const values = pairs
      .filter(([key]) => key === name)
      .map(([, value]) => value.trim())
      .filter(Boolean);
    found[name] = Array.isArray(defaultValue) ? [...new Set(values)] : (values.at(-1) ?? defaultValue);
  }
  return /** @type {any} */ (found);
}

/**
 * The address of filters: only those that are set, always in the same order.
 *
 * @param {SearchFilters} filters
 * @returns {string} without `?`
 */
export function formatSearch(filters) {
  /** @type {string[]} */
  const pairs = [];
  for (const [name, defaultValue] of Object.entries(NO_SEARCH)) {
    const value = filters[/** @type {keyof SearchFilters} */ (name)];
    const values = Array.isArray(value) ? value : value === defaultValue ? [] : [value];
    pairs.push(...values.map((one) => `${name}=${encodeURIComponent(one)}`));
  }
  return pairs.join('&');
}

/** @param {string} text @returns {string} unchanged if its escapes are invalid */
function decode(text) {
  try {
    return decodeURIComponent(text.replaceAll('+', ' '));
  } catch {
    return text;
  }
}

/** Whether a filter outside the first row is set. @param {SearchFilters} filters */
export const hasSecondaryFilter = ({ attribute, author, since, until, tag, video, runs }) =>
  attribute.length + author.length + tag.length > 0 || since !== '' || until !== '' || video !== '' || runs !== 'current';

/**
 * The labels that the words of the label filter mean; empty if these words are their names.
 *
 * @param {readonly {name: string}[]} labels   those that the search has found for the words
 * @param {readonly string[]} words
 * @param {number} [maxNames]   number of names to list
 */
export function describeMatchedLabels(labels, words, maxNames = Infinity) {
  const names = [...new Set(labels.map(({ name }) => name))];
  const typed = new Set(words.map((word) => word.toLowerCase()));
  if (names.every((name) => typed.has(name.toLowerCase()))) return '';
  return `${names.length === 1 ? 'Label' : 'Labels'}: ${listNames(names, maxNames)}.`;
}

/** The id of a track across all runs. @param {{run: string, key: string}} track */
export const idOf = ({ run, key }) => `${run}/${key}`;

/**
 * The selection after a click or a key.
 *
 * @param {ReadonlySet<string>} selected
 * @param {readonly FoundTrack[]} tracks   in their order
 * @param {number} anchor                  index of the start of a range
 * @param {number} index                      present index
 * @param {'only'|'toggle'|'range'} mode
 * @returns {Set<string>}
 */
export function selectTracks(selected, tracks, anchor, index, mode) {
  if (!tracks[index]) return new Set(selected);
  if (mode === 'only') return new Set([idOf(tracks[index])]);
  if (mode === 'range') {
    const [low, high] = anchor < index ? [anchor, index] : [index, anchor];
    return new Set(tracks.slice(Math.max(0, low), high + 1).map(idOf));
  }
  const next = new Set(selected);
  if (!next.delete(idOf(tracks[index]))) next.add(idOf(tracks[index]));
  return next;
}

/**
 * Tracks with those that an action has changed replaced.
 *
 * @param {readonly FoundTrack[]} tracks
 * @param {readonly FoundTrack[]} changed
 * @returns {FoundTrack[]}
 */
export function withChanged(tracks, changed) {
  const now = new Map(changed.map((track) => [idOf(track), track]));
  return tracks.map((track) => now.get(idOf(track)) ?? track);
}
