// @ts-check
/** Pictures that may be missing: in their place stands a dashed frame, never the browser's sign of a broken picture. */

import { h, setAttribute } from './dom.js';

/**
 * @param {import('./dom.js').Props} props   of the `img`; `src` may be null
 * @returns {HTMLImageElement}
 */
export function pictureThatMayMiss({ src, ...props }) {
  const image = h('img', { alt: '', ...props });
  image.addEventListener('error', () => image.classList.add('no-picture'));
  showPicture(image, /** @type {string|null|undefined} */ (src));
  return image;
}

/**
 * Show another picture in its place, or none.
 *
 * @param {HTMLImageElement} image   made by `pictureThatMayMiss`
 * @param {string|null|undefined} address
 */
export function showPicture(image, address) {
  if (address && image.getAttribute('src') === address) return; // one that could not be read stays so
  image.classList.toggle('no-picture', !address);
  setAttribute(image, 'src', address || null);
}
