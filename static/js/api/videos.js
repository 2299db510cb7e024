// @ts-check
/** Routes of videos and their pictures. */

import { encode, queryText } from './http.js';
import { expectObject } from './shapes.js';
import { upload } from './upload.js';

/** @typedef {import('../types.js').Video} Video */
/** @typedef {import('./http.js').Call} Call */
/** @typedef {{path: string, parent: string|null, folders: string[], videos: {name: string, path: string, size: number}[], truncated: boolean}} Folder   `truncated`: there are more; these are the first by name */

const VIDEO = /** @type {const} */ ({ id: 'string', name: 'string', state: 'string', runs: 'number', warnings: 'array', review: 'object' });

const TABLE = /** @type {const} */ ({ frames: 'number', time_base: 'array', steps: 'array', keys: 'array', corrupt: 'array' });
const FOLDER = /** @type {const} */ ({ path: 'string', folders: 'array', videos: 'array', truncated: 'boolean' });

/** @param {import('./http.js').Routes} routes */
export const videoRoutes = ({ base, json, list, object, send }) => ({
  /** @param {Call} [call] @returns {Promise<Video[]>} */
  videos: (call) => list('GET /videos', [], VIDEO, call, 'videos'),
  /** @param {{label?: string, attribute?: string, value?: string, state?: string}} wanted @param {Call} [call] @returns {Promise<{videos: Record<string, number>, left: number, unreadable: number}>} videos: number of matching tracks by video id; left: videos not counted yet, ask again */
  matchingVideos: (wanted, call) =>
    object('GET /videos/matching', [], { videos: 'object', left: 'number', unreadable: 'number' }, { ...call, query: wanted }),
  /** @param {string} id @param {Call} [call] @returns {Promise<Video>} */
  video: (id, call) => object('GET /videos/…', [id], VIDEO, call),
  /** @param {string} path @param {Call} [call] @returns {Promise<Video>} */
  addVideo: (path, call) => object('POST /videos', [], VIDEO, { ...call, body: { path }, timeout: 60_000 }),
  /** @param {string} id @param {Call} [call] @returns {Promise<void>} */
  removeVideo: (id, call) => json('DELETE /videos/…', [id], call),
  /**
   * @param {File} file
   * @param {{onProgress?: (sent: number, total: number) => void, signal?: AbortSignal}} [options]
   * @returns {Promise<Video>}
   */
  uploadVideo: async (file, options = {}) =>
    expectObject('PUT /uploads/…', await upload(`${base}/uploads/${encode(file.name)}`, file, options), VIDEO),
  /** @param {string} id @param {Call} [call] @returns {Promise<import('../types.js').FrameTableData>} */
  frameTable: (id, call) => object('GET /videos/…/table', [id], TABLE, call),
  /** @param {string|null} path   null: the start folder @param {Call} [call] @returns {Promise<Folder>} */
  browse: (path, call) => object('GET /browse', [], FOLDER, { ...call, query: { path } }),
  /** @param {string} id @returns {string} address of the picture */
  thumbnailUrl: (id) => `${base}/videos/${encode(id)}/thumbnail`,
  /** @param {string} id @param {number} frame @returns {string} address of the picture */
  frameUrl: (id, frame) => `${base}/videos/${encode(id)}/frames/${frame}`,
  /**
   * @param {string} id
   * @param {number} frame
   * @param {import('../types.js').Box} part   whole px, inside the picture
   * @param {number} size                      longer side, px
   * @returns {string} address of a part of the picture
   */
  framePartUrl: (id, frame, [x1, y1, x2, y2], size) =>
    `${base}/videos/${encode(id)}/frames/${frame}/crop${queryText({ x1, y1, x2, y2, size })}`,
  /**
   * The picture of a frame, with the ordinal that the server reports. For a preview the server may send a small, soft
   * and inexact picture.
   *
   * @param {string} id
   * @param {number} frame
   * @param {{width?: number, preview?: boolean} & Call} [options]
   * @returns {Promise<{blob: Blob, ordinal: number, exact: boolean}>}
   */
  frame: async (id, frame, { width, preview, ...call } = {}) => {
    const query = { width, preview: preview ? 'true' : undefined };
    const answer = await send(`/videos/${encode(id)}/frames/${frame}`, { ...call, query });
    const ordinal = answer.headers.get('X-Frame-Ordinal');
    expectObject('GET /videos/…/frames/…', { ordinal: ordinal === null ? null : Number(ordinal) }, { ordinal: 'number' });
    return { blob: await answer.blob(), ordinal: Number(ordinal), exact: answer.headers.get('X-Frame-Exact') !== 'false' };
  },
});
