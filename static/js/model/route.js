// @ts-check
/**
 * Addresses inside the page: the part after `#`. Pure.
 *
 *     #/                                        library
 *     #/review/VIDEO/RUN?frame=12&track=m7      RUN may be `-`: the newest; TRACK may be `next`: the first of the queue
 *     #/compare?a=run:R&b=annotation:R
 *     #/team, #/team/NAME                       all people, one of them
 *     #/search?label=60&uncertainty_min=0.3     filters of the search, see model/search.js
 *     #/models, #/files, #/labels
 *
 * @typedef {import('../state-types.js').Route} Route
 */

import { formatSearch, parseSearch } from './search.js';

/** In place of a track: the first undecided track of the queue when the review opens. */
export const NEXT_TRACK = 'next';

/** The address that starts the review of a video. @param {string} video */
export const reviewAddress = (video) => formatRoute({ screen: 'review', video, run: null, frame: null, track: NEXT_TRACK });

/** @param {Route} route @returns {string} begins with `#/` */
export function formatRoute(route) {
  if (route.screen === 'review') {
    const pairs = [];
    if (route.frame !== null) pairs.push(`frame=${route.frame}`);
    if (route.track !== null) pairs.push(`track=${encodeURIComponent(route.track)}`);
    return `#/review/${route.video}/${route.run ?? '-'}${pairs.length ? `?${pairs.join('&')}` : ''}`;
  }
  if (route.screen === 'search') return `#/search${route.query ? `?${route.query}` : ''}`;
  if (route.screen === 'compare') return `#/compare?a=${encodeURIComponent(route.a)}&b=${encodeURIComponent(route.b)}`;
  if (route.screen === 'team') return route.person === null ? '#/team' : `#/team/${encodeURIComponent(route.person)}`;
  if (route.screen === 'models' || route.screen === 'files' || route.screen === 'labels') return `#/${route.screen}`;
  return '#/';
}

/**
 * @param {string} hash   with or without `#`
 * @returns {Route} the library, if the address is not known
 */
export function parseRoute(hash) {
  const [path, query = ''] = hash.replace(/^#/, '').split('?');
  const values = pairsOf(query);
  const parts = path.split('/').filter((part) => part !== '');
  if (parts[0] === 'review' && /^[0-9a-f]{64}$/.test(parts[1] ?? '')) {
    const run = parts[2] ?? '-';
    const frame = values.frame ?? '';
    return {
      screen: 'review',
      video: parts[1],
      run: /^[0-9a-f]{32}$/.test(run) ? run : null,
      frame: /^\d{1,9}$/.test(frame) ? Number(frame) : null,
      track: values.track || null,
    };
  }
  const sidePattern = /^(run|annotation|truth):[0-9a-f]{32}$/;
  if (parts[0] === 'compare' && sidePattern.test(values.a ?? '') && sidePattern.test(values.b ?? '')) {
    return { screen: 'compare', a: values.a, b: values.b };
  }
  if (parts[0] === 'team' && parts.length <= 2) return { screen: 'team', person: parts[1] === undefined ? null : decode(parts[1]) };
  if (parts.length === 1 && parts[0] === 'search') return { screen: 'search', query: formatSearch(parseSearch(query)) };
  if (parts.length === 1 && (parts[0] === 'models' || parts[0] === 'files' || parts[0] === 'labels')) return { screen: parts[0] };
  return { screen: 'library' };
}

/**
 * The address of a run, at the frame on the screen if that is of the same video.
 * @param {Pick<import('../state-types.js').State, 'route'|'review'>} state
 * @param {string} video
 * @param {string} run
 * @returns {string}
 */
export function runAddress({ route, review }, video, run) {
  const isOpen = route.screen === 'review' && route.video === video;
  // the route names the frame of the last link, not that of the cursor
  const frame = !isOpen ? null : review?.timebase && review.video.id === video ? review.frame : route.frame;
  return formatRoute({ screen: 'review', video, run, frame, track: null });
}

/**
 * The address of the present place in a review; null: not known yet, or the video is playing.
 *
 * @param {Pick<import('../state-types.js').State, 'route'|'review'>} state
 * @returns {string|null}
 */
export function currentAddress({ route, review }) {
  if (route.screen !== 'review' || !review?.timebase || review.playing || review.video.id !== route.video) return null;
  // while another run is being opened, the previous one is still on the screen
  if (route.run !== null && review.run !== null && review.run.id !== route.run) return null;
  // the track in the address is selected when the tracks have arrived
  const track = review.selected ?? (review.tracks === null ? route.track : null);
  return formatRoute({ screen: 'review', video: review.video.id, run: review.run?.id ?? route.run, frame: review.frame, track });
}

/**
 * Whether another address shows the same screen and, on it, the same run of the same video.
 *
 * @param {Route} before
 * @param {Route} route
 * @param {string|null} run   the open run, used if the earlier address of the review names none
 * @returns {boolean}
 */
export function isSameView(before, route, run) {
  if (before.screen !== 'review' || route.screen !== 'review') return before.screen === route.screen;
  return before.video === route.video && (before.run === route.run || (before.run ?? run) === route.run);
}

/** @param {string} query @returns {Record<string, string>} */
function pairsOf(query) {
  /** @type {Record<string, string>} */
  const values = {};
  for (const pair of query.split('&')) {
    const [name, value = ''] = pair.split('=');
    const text = decode(value);
    if (text !== null) values[name] = text;
  }
  return values;
}

/** @param {string} text @returns {string|null} null: an invalid escape, treated as absent */
function decode(text) {
  try {
    return decodeURIComponent(text);
  } catch {
    return null;
  }
}
