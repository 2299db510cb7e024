// @ts-check
/** Search and sort order of the videos in the library. Pure. */

import { undecidedCount } from './open_videos.js';

/** @typedef {import('../types.js').Video} Video */

/** Sorts numbers in names by value. Created once, because that is slow. */
const names = new Intl.Collator(undefined, { numeric: true });

/** @type {Record<string, {label: string, compare: (a: Video, b: Video) => number}>} */
export const SORTS = {
  newest: { label: 'Newest first', compare: (a, b) => (a.created < b.created ? 1 : a.created > b.created ? -1 : 0) },
  name: { label: 'Name', compare: (a, b) => names.compare(a.name, b.name) },
  open: { label: 'Most left to review', compare: (a, b) => undecidedCount(b) - undecidedCount(a) },
  longest: { label: 'Longest first', compare: (a, b) => (b.duration ?? 0) - (a.duration ?? 0) },
};

/**
 * The videos that a search finds, in order.
 *
 * @param {readonly Video[]} videos
 * @param {string} text    every word must occur in name or path
 * @param {string} sort
 * @returns {Video[]}
 */
export function arrange(videos, text, sort) {
  const words = text.toLowerCase().split(/\s+/).filter(Boolean);
  const found = videos.filter((video) => {
    const where = `${video.name} ${video.path}`.toLowerCase();
    return words.every((word) => where.includes(word));
  });
  return found.sort((SORTS[sort] ?? SORTS.newest).compare);
}
