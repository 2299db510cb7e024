// @ts-check
/** Pictures that may be missing: a dashed frame is shown in place of the browser's broken-picture icon. */

import { h, setAttribute } from './dom.js';

/**
 * @param {import('./dom.js').Props} props   of the `img`; `src` may be null
 * @returns {HTMLImageElement}
 */
export function imageWithPlaceholder({ src, ...props }) {
  const image = h('img', { alt: '', ...props });
  image.addEventListener('error', () => image.classList.add('no-picture'));
  setImageSource(image, /** @type {string|null|undefined} */ (src));
  return image;
}

/**
 * A picture that is hidden until it is given an address, and again if it cannot be read.
 *
 * @param {`img.${string}`} selector
 * @param {import('./dom.js').Props} props   of the `img`
 * @returns {HTMLImageElement}
 */
export function imageHiddenUntilSet(selector, props) {
  const image = h(selector, { alt: '', ...props, hidden: true });
  image.addEventListener('error', () => {
    image.hidden = true;
    image.classList.add('no-picture');
  });
  return image;
}

/**
 * Show another picture, or none.
 *
 * @param {HTMLImageElement} image   made by `imageWithPlaceholder`
 * @param {string|null|undefined} url
 */
export function setImageSource(image, url) {
  if (url && image.getAttribute('src') === url) return; // a picture that could not be read is not loaded again
  image.classList.toggle('no-picture', !url);
  setAttribute(image, 'src', url || null);
}

/**
 * Load the pictures again that could not be read, because the server was unreachable.
 *
 * @param {ParentNode} [root]
 */
export function reloadFailedImages(root = document) {
  for (const image of root.querySelectorAll('img.no-picture[src]')) {
    const url = image.getAttribute('src');
    image.classList.remove('no-picture');
    /** @type {HTMLElement} */ (image).hidden = false;
    image.setAttribute('src', /** @type {string} */ (url)); // the browser loads the same address anew
  }
}
