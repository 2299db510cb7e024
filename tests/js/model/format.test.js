// @ts-check
import assert from 'node:assert/strict';
import { readdirSync, readFileSync } from 'node:fs';
import { test } from 'node:test';

import { bytes, clock, count, figure, frameSpan, percent, plural, roundPercent, timeLeft } from '../../../static/js/model/format.js';
import { shortNumber } from '../../../static/js/model/describe_events.js';

test('a number never has an exponent, and keeps its significant digits', () => {
  const cases = /** @type {[number, number|undefined, string][]} */ ([
    [4.189, undefined, '4.19'],
    [1234.5, undefined, '1,230'],
    [1234.5, 6, '1,234.5'],
    [132400, undefined, '132,400'],
    [0, undefined, '0'],
    [-0, undefined, '0'],
    [9.02e-7, undefined, '<0.0001'],
    [-9.02e-7, 2, '>-0.0001'],
    [1e-6, 6, '0.000001'],
    [1.5e21, undefined, '1,500,000,000,000,000,000,000'],
    [0.00021, 2, '0.00021'],
    [-3.14159, 3, '-3.14'],
  ]);
  for (const [value, digits, text] of cases) assert.equal(figure(value, digits), text);
  assert.deepEqual([figure(null), figure(Number.NaN), figure(Infinity), count(undefined)], ['–', '–', '–', '–']);
  for (let power = -12; power < 22; power += 1)
    for (const of of [figure, shortNumber]) assert.doesNotMatch(of(1.234 * 10 ** power), /e[+-]?\d/);
});

test('one thing is one thing', () => {
  assert.deepEqual(
    [plural(1, 'group'), plural(0, 'group'), plural(1200, 'group'), plural(1, 'class', 'classes')],
    ['1 group', '0 groups', '1,200 groups', '1 class'],
  );
});

test('a share that is not quite none or all does not say so', () => {
  assert.deepEqual([0, 0.004, 0.013, 0.5, 0.995, 1, null].map(roundPercent), ['0 %', '<1 %', '1 %', '50 %', '>99 %', '100 %', '–']);
});

test('numbers read as people write them', () => {
  assert.deepEqual([frameSpan(20, 20), frameSpan(20, 1034)], ['20', '20–1,034']);
  assert.deepEqual(
    [bytes(0), bytes(999), bytes(1500), bytes(3_700_000), bytes(250e9)],
    ['0 bytes', '999 bytes', '1.5 kB', '3.7 MB', '250 GB'],
  );
  assert.deepEqual([clock(0), clock(12.4), clock(3723), clock(null)], ['0:00', '0:12', '1:02:03', '–']);
  assert.deepEqual(
    [timeLeft(3), timeLeft(24), timeLeft(130), timeLeft(7200)],
    ['a few seconds left', 'about 25 s left', 'about 2 min left', 'about 2.0 h left'],
  );
  assert.deepEqual(
    [figure(0.16044), figure(132400), figure(null), percent(0.5432), percent(1)],
    ['0.16', '132,400', '–', '54.3 %', '100 %'],
  );
});

/** The texts of the whole page, by file. */
const sources = readdirSync('static/js', { recursive: true })
  .map(String)
  .filter((name) => name.endsWith('.js'))
  .map((name) => /** @type {const} */ ([name, readFileSync(`static/js/${name}`, 'utf8').split('\n')]));

/** @param {RegExp} wrong @param {(line: string, name: string) => boolean} [allowed] */
const found = (wrong, allowed = () => false) =>
  sources.flatMap(([name, lines]) =>
    lines
      .filter((line) => wrong.test(line) && !/^\s*(\*|\/\/|\/\*)/.test(line) && !allowed(line, name))
      .map((line) => `${name}: ${line.trim()}`),
  );

test('on every screen a count and its word agree: plural() writes them', () => {
  // a number of something and a plural in one text; where a line tells 1 from more by itself, or counts what is never one, it may
  const number = String.raw`\$\{(?:count\()?[^{}]*(?:length|size|total|_done|frames|tracks|corrections|pictures)\)?\} (?!is\b|was\b|has\b|does\b)[a-z-]+s\b`;
  assert.deepEqual(
    found(new RegExp(number), (line) =>
      /=== 1 \?|plural\(|parts\.length\} parts|importing\} (?:of \$\{added\.length\} )?videos/.test(line),
    ),
    [],
  );
  assert.deepEqual(
    found(/\$\{count\([^{}]*\)\} (?!is\b|was\b|has\b)[a-z-]+s\b/, (line) => /=== 1 \?/.test(line)),
    [],
  );
});

test('on every screen figure() writes numbers of unknown size', () => {
  const read = ['model/gate_lane.js', 'views/lanes/tau_slider.js'];
  assert.deepEqual(
    found(/toPrecision|toExponential/, (_, name) => read.includes(name.replaceAll('\\', '/'))),
    [],
    'these two round a number and write none',
  );
});

test('on every screen a picture of a label or a crop can be missing', () => {
  const own = ['views/library_card.js', 'views/library_welcome.js', 'views/topbar.js', 'views/images.js'];
  assert.deepEqual(
    found(/h\('img'/, (_, name) => own.includes(name.replaceAll('\\', '/'))),
    [],
    'the others hide theirs, or ship with the page',
  );
});
