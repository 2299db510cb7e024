// @ts-check
/** Requests: time limit, cancellation, checks of the answer, and every failure as an `ApiError`. */

import { ApiError, errorFromResponse, toApiError } from './errors.js';
import { expectColumns, expectList, expectObject } from './shapes.js';

/**
 * @typedef {object} RequestOptions
 * @property {string} [method]
 * @property {any} [body]                sent as JSON, unless it is a Blob or text
 * @property {string} [type]             media type of a Blob or text body
 * @property {Record<string, string>} [headers]
 * @property {Record<string, string|number|null|undefined>} [query]   null and undefined are omitted
 * @property {AbortSignal} [signal]
 * @property {number} [timeout]          ms; default 20,000
 */

/** @typedef {import('./shapes.js').Fields} Fields */
/** @typedef {(path: string, options?: RequestOptions) => Promise<Response>} Send */
/** @typedef {{signal?: AbortSignal, timeout?: number}} Call */
/** @typedef {ReturnType<typeof createRoutes>} Routes */

/** @param {{base: string, fetch: typeof fetch, signal?: AbortSignal}} setup @returns {Send} resolves only for 2xx */
export function createSend({ base, fetch, signal: pageSignal }) {
  return async (path, options = {}) => {
    const signals = [AbortSignal.timeout(options.timeout ?? 20_000)];
    if (options.signal) signals.push(options.signal);
    if (pageSignal) signals.push(pageSignal);
    const headers = new Headers(options.headers);
    let body = options.body;
    if (body !== undefined && typeof body !== 'string' && !(body instanceof Blob)) {
      body = JSON.stringify(body);
      headers.set('Content-Type', 'application/json');
    } else if (options.type) {
      headers.set('Content-Type', options.type);
    }
    const request = {
      method: options.method ?? 'GET',
      headers,
      body,
      signal: AbortSignal.any(signals),
      credentials: /** @type {const} */ ('same-origin'),
    };
    /** @type {Response} */
    let answer;
    try {
      answer = await fetch(base + path + queryText(options.query), request);
      if (answer.ok) return answer;
      throw errorFromResponse(answer.status, await answer.text());
    } catch (cause) {
      throw toApiError(cause);
    }
  };
}

/** Parse the JSON of an answer. @param {Response} answer @returns {Promise<any>} undefined for 204 */
export async function readJson(answer) {
  if (answer.status === 204) return undefined;
  try {
    return await answer.json();
  } catch (cause) {
    if (!(cause instanceof SyntaxError)) throw toApiError(cause);
    const message = 'The answer is not from the review tool, but perhaps from a proxy in between. Reload the page.';
    throw new ApiError(0, 'bad_answer', message, { cause });
  }
}

/**
 * What the functions of the routes are built with. A route is written `POST /runs/…/cancel`, with one id for each `…`;
 * messages about wrong answers name it like that.
 *
 * @param {string} base   prefix of every path
 * @param {Send} send
 */
export function createRoutes(base, send) {
  /** @param {string} route @param {(string|number)[]} [ids] @param {RequestOptions} [options] @returns {Promise<any>} */
  async function json(route, ids = [], options = {}) {
    const [method, path] = route.split(' ');
    let count = 0;
    const address = path.replaceAll('…', () => encode(ids[count++]));
    return readJson(await send(address, { ...options, method }));
  }
  return {
    base,
    send,
    json,
    /** The answer, with checked fields. @param {string} route @param {(string|number)[]} ids @param {Fields} fields @param {RequestOptions} [options] */
    object: async (route, ids, fields, options) => expectObject(route, await json(route, ids, options), fields),
    /**
     * A list of objects with checked fields.
     * @param {string} route
     * @param {(string|number)[]} ids
     * @param {Fields} fields
     * @param {RequestOptions} [options]
     * @param {string} [name]   the field of the answer that has the list; unset: the answer is the list
     */
    async list(route, ids, fields, options, name) {
      const answer = await json(route, ids, options);
      return expectList(route, name === undefined ? answer : expectObject(route, answer, { [name]: 'array' })[name], fields);
    },
    /** Columns of equal length. @param {string} route @param {(string|number)[]} ids @param {string[]} names @param {RequestOptions} [options] */
    columns: async (route, ids, names, options) => expectColumns(route, await json(route, ids, options), names),
  };
}

/** An id or a name as a part of a path. @param {string|number} part */
export const encode = (part) => encodeURIComponent(part);

/** @param {RequestOptions['query']} query @returns {string} `?a=1&b=2`, or an empty string */
export function queryText(query) {
  const pairs = Object.entries(query ?? {}).filter(([, value]) => value !== null && value !== undefined);
  return pairs.length ? `?${new URLSearchParams(pairs.map(([name, value]) => [name, String(value)]))}` : '';
}
