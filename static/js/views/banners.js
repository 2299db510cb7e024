// @ts-check
/** Banners about problems that block the work, above everything until they are solved. */

import { hideBanner } from '../store/actions/page.js';
import { h, reconcile, setText } from './dom.js';
import { icon } from './icons.js';
import { dismiss } from '../core/preferences.js';

/** @typedef {import('../state-types.js').Banner} Banner */

/**
 * @param {import('../page-types.js').App} app
 * @returns {import('../page-types.js').View}
 */
export function createBanners(app) {
  const element = h('section.banners', { 'aria-label': 'Warnings', hidden: true });
  /** @type {readonly Banner[]|null} */
  let shownBanners = null;

  /** @param {Banner} banner */
  function createBanner(banner) {
    const operation = banner.action && app.operations.find(({ id }) => id === banner.action?.operation);
    return h(
      'div',
      { class: `banner banner-${banner.tone}`, role: banner.tone === 'info' ? 'status' : 'alert' },
      icon(banner.id === 'offline' ? 'offline' : banner.tone === 'info' ? 'info' : 'alert'),
      h('span.banner-text.grow'),
      operation && h('button.btn.btn-small', { title: operation.tooltip, onclick: () => operation.run(app) }, banner.action?.label),
      h(
        'button.btn.btn-quiet.btn-icon.btn-small',
        {
          'aria-label': 'Hide this warning',
          onclick: () => {
            if (banner.once) dismiss(banner.once);
            app.store.dispatch(hideBanner, banner.id);
          },
        },
        icon('close'),
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
    destroy: () => element.remove(),
  };
}
