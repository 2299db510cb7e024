// @ts-check
/** Pictures that may be missing: a dashed frame is shown in place of the browser's broken-picture icon. */

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
 * Show another picture, or none.
 *
 * @param {HTMLImageElement} image   made by `pictureThatMayMiss`
 * @param {string|null|undefined} address
 */
export function showPicture(image, address) {
  if (address && image.getAttribute('src') === address) return; // a picture that could not be read is not loaded again
  image.classList.toggle('no-picture', !address);
  setAttribute(image, 'src', address || null);
}
