// @ts-check
/** Banners about problems that block the work, above everything until they are solved. */

import { hideBanner } from '../store/actions/page.js';
import { h, reconcile, setText } from './dom.js';
import { icon, iconButton } from './icons.js';
import { dismiss } from '../core/preferences.js';

/** @typedef {import('../state-types.js').Banner} Banner */

/** @type {import('../page-types.js').CreatePart} */
export function createBanners(app) {
  const element = h('section.banners', { 'aria-label': 'Warnings', hidden: true });
  /** @type {readonly Banner[]|null} */ let shownBanners = null;

  /** @param {Banner} banner */
  function createBanner(banner) {
    const operation = banner.action && app.operations.find(({ id }) => id === banner.action?.operation);
    return h(
      'div',
      { class: `banner banner-${banner.tone}`, role: banner.tone === 'info' ? 'status' : 'alert' },
      icon(banner.id === 'offline' ? 'offline' : banner.tone === 'info' ? 'info' : 'alert'),
      h('span.banner-text.grow'),
      operation && h('button.btn.btn-small', { title: operation.tooltip, onclick: () => operation.run(app) }, banner.action?.label),
      iconButton(
        'close',
        'Hide this warning',
        () => {
          if (banner.once) dismiss(banner.once);
          app.store.dispatch(hideBanner, banner.id);
        },
        null,
      ),
    );
  }

  return {
    element,
    update(state) {
      if (state.banners === shownBanners) return;
      shownBanners = state.banners;
      element.hidden = shownBanners.length === 0;
      reconcile(
        element,
        shownBanners,
        (banner) => `${banner.id}/${banner.tone}`,
        createBanner,
        (bannerElement, banner) => {
          const text = bannerElement.querySelector('.banner-text');
          if (text) setText(text, banner.text);
        },
      );
    },
  };
}
