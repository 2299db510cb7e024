// @ts-check
/**
 * Open tracks in the other videos of the library. Pure.
 *
 * @typedef {import('../types.js').Video} Video
 * @typedef {{videos: number, tracks: number, next: Video|null}} OpenVideos   `next`: the next video to review; null: none
 */
import { count, plural } from './format.js';

/** Number of tracks without a decision. @param {Video} video */
export const undecidedCount = ({ review }) => Math.max(0, review.tracks - review.reviewed);

/**
 * @param {readonly Video[]|null} videos   in the order of the library
 * @param {string|undefined} present       the video on the screen
 * @returns {OpenVideos} `next`: the next video with open tracks after the present one, else the first one
 */
export function openVideos(videos, present) {
  const all = videos ?? [];
  const at = all.findIndex(({ id }) => id === present);
  const others = [...all.slice(at + 1), ...all.slice(0, Math.max(0, at))].filter(
    (video) => video.state === 'ready' && !video.missing && video.latest_run !== null && undecidedCount(video) > 0,
  );
  return { videos: others.length, tracks: others.reduce((sum, video) => sum + undecidedCount(video), 0), next: others[0] ?? null };
}

/**
 * The message after every track of a video is reviewed. Videos without a finished run are not mentioned.
 *
 * @param {OpenVideos} left
 * @param {number} total   tracks of this video
 * @returns {string}
 */
export function reviewedMessage({ videos, tracks }, total) {
  const here = total > 0 ? 'All tracks of this video are reviewed' : 'This video has no track to review';
  if (tracks === 0) return `${here}. No other video has an open track.`;
  const where = videos === 1 ? '1 other video' : `${count(videos)} other videos`;
  return `${here}. ${where} ${videos === 1 ? 'has' : 'have'} ${plural(tracks, 'open track')}.`;
}
