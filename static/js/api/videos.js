// @ts-check
/** Routes of videos and their pictures. */

import { encode, queryText } from './http.js';
import { expectList, expectObject } from './shapes.js';
import { upload } from './upload.js';

/** @typedef {import('../types.js').Video} Video */
/** @typedef {{signal?: AbortSignal, timeout?: number}} Call */
/** @typedef {{path: string, parent: string|null, folders: string[], videos: {name: string, path: string, size: number}[], truncated: boolean}} Folder   `truncated`: there are more; these are the first by name */

const VIDEO = /** @type {const} */ ({ id: 'string', name: 'string', state: 'string', runs: 'number', warnings: 'array', review: 'object' });

/** @param {import('./http.js').Routes} setup */
export function videoRoutes({ base, json, send }) {
  return {
    /** @param {Call} [call] @returns {Promise<Video[]>} */
    videos: async (call) => {
      const answer = expectObject('GET /videos', await json('/videos', call), { videos: 'array' });
      return expectList('GET /videos', answer.videos, VIDEO);
    },
    /** @param {{label?: string, attribute?: string, value?: string, state?: string}} wanted @param {Call} [call] @returns {Promise<{videos: Record<string, number>, left: number, unreadable: number}>} videos: number of matching tracks by video id; left: videos not counted yet, ask again */
    matchingVideos: async (wanted, call) =>
      expectObject('GET /videos/matching', await json('/videos/matching', { ...call, query: wanted }), {
        videos: 'object',
        left: 'number',
        unreadable: 'number',
      }),
    /** @param {string} id @param {Call} [call] @returns {Promise<Video>} */
    video: async (id, call) => expectObject('GET /videos/…', await json(`/videos/${encode(id)}`, call), VIDEO),
    /** @param {string} path @param {Call} [call] @returns {Promise<Video>} */
    addVideo: async (path, call) =>
      expectObject('POST /videos', await json('/videos', { ...call, method: 'POST', body: { path }, timeout: 60_000 }), VIDEO),
    /** @param {string} id @param {Call} [call] @returns {Promise<void>} */
    removeVideo: (id, call) => json(`/videos/${encode(id)}`, { ...call, method: 'DELETE' }),
    /**
     * @param {File} file
     * @param {{onProgress?: (sent: number, total: number) => void, signal?: AbortSignal}} [options]
     * @returns {Promise<Video>}
     */
    uploadVideo: async (file, options = {}) =>
      expectObject('PUT /uploads/…', await upload(`${base}/uploads/${encode(file.name)}`, file, options), VIDEO),
    /** @param {string} id @param {Call} [call] @returns {Promise<import('../types.js').FrameTableData>} */
    frameTable: async (id, call) =>
      expectObject('GET /videos/…/table', await json(`/videos/${encode(id)}/table`, call), {
        frames: 'number',
        time_base: 'array',
        steps: 'array',
        keys: 'array',
        corrupt: 'array',
      }),
    /** @param {string|null} path   null: the start folder @param {Call} [call] @returns {Promise<Folder>} */
    browse: async (path, call) =>
      expectObject('GET /browse', await json('/browse', { ...call, query: { path } }), {
        path: 'string',
        folders: 'array',
        videos: 'array',
        truncated: 'boolean',
      }),
    /** @param {string} id @returns {string} address of the picture */
    thumbnailUrl: (id) => `${base}/videos/${encode(id)}/thumbnail`,
    /**
     * @param {string} id
     * @param {number} frame   ordinal
     * @param {{width?: number, format?: 'jpeg'|'webp'}} [options]
     * @returns {string} address of the picture
     */
    frameUrl: (id, frame, options) => `${base}/videos/${encode(id)}/frames/${frame}${queryText(options)}`,
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
     * @param {{width?: number, format?: 'jpeg'|'webp', preview?: boolean, signal?: AbortSignal, timeout?: number}} [options]
     * @returns {Promise<{blob: Blob, ordinal: number, pts: number|null, exact: boolean}>}
     */
    frame: async (id, frame, { width, format, preview, ...call } = {}) => {
      const query = { width, format, preview: preview ? 'true' : undefined };
      const answer = await send(`/videos/${encode(id)}/frames/${frame}`, { ...call, query });
      const ordinal = answer.headers.get('X-Frame-Ordinal');
      const pts = answer.headers.get('X-Frame-Pts');
      expectObject('GET /videos/…/frames/…', { ordinal: ordinal === null ? null : Number(ordinal) }, { ordinal: 'number' });
      const exact = answer.headers.get('X-Frame-Exact') !== 'false';
      return { blob: await answer.blob(), ordinal: Number(ordinal), pts: pts === null ? null : Number(pts), exact };
    },
  };
}
