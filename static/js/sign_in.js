// @ts-check
/**
 * The page where people sign in. The token of a link follows `#`, which browsers do not send to a server. If an address
 * of the review tool follows `#`, the page goes there after the sign-in.
 */

import { errorMessage } from './api/errors.js';
import { createSend, readJson } from './api/http.js';

const send = createSend({ base: '/api', fetch: globalThis.fetch.bind(globalThis) });
const form = /** @type {HTMLFormElement} */ (document.getElementById('sign-in'));
const field = /** @type {HTMLInputElement} */ (document.getElementById('token'));
const problem = /** @type {HTMLElement} */ (document.getElementById('problem'));
const fragment = location.hash.slice(1);
const address = fragment.startsWith('/') ? `#${fragment}` : '';

const continueToPage = () => location.replace(`/${address}`);

/** @param {string} token */
async function signIn(token) {
  problem.textContent = '';
  try {
    await readJson(await send('/session', { method: 'POST', body: { token } }));
    continueToPage();
  } catch (thrown) {
    problem.textContent = errorMessage(thrown);
    field.focus();
    field.select();
  }
}

form.addEventListener('submit', (event) => {
  event.preventDefault();
  void signIn(field.value.trim());
});
// until this script runs, the browser would submit the form itself, with the token in the address
/** @type {HTMLButtonElement} */ (form.querySelector('button')).disabled = false;

if (fragment !== '' && address === '') {
  history.replaceState(null, '', '/sign-in'); // removes the token from the address and the history
  field.value = fragment;
  void signIn(fragment);
} else {
  // go on at once if the person is signed in already, for example after a link from elsewhere
  send('/session').then(continueToPage, () => {});
}
