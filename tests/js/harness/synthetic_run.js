// @ts-check
/** A drive of any length with any number of tracks, the same for the same seed. */

/** @param {number} seed @returns {() => number} 0..1 */
export function seededRandom(seed) {
  let a = seed >>> 0;
  return () => {
    a = (a + 0x6d2b79f5) >>> 0;
    let t = Math.imul(a ^ (a >>> 15), a | 1);
    t ^= t + Math.imul(t ^ (t >>> 7), t | 61);
    return ((t ^ (t >>> 14)) >>> 0) / 4294967296;
  };
}

/** @param {number} frames @param {number} count @returns {{tracks: any, lanes: any}} */
export function syntheticRun(frames, count) {
  const next = seededRandom(7);
  /** @type {any} */
  const tracks = { tau: 15, complete: true };
  /** @type {any} */
  const lanes = { track: [], first: [], last: [], source: [] };
  for (let i = 0; i < count; i += 1) {
    const first = Math.floor(next() * (frames - 20));
    const last = Math.min(frames - 1, first + 12 + Math.floor(next() ** 3 * 400));
    const uncertainty = next() ** 3;
    const cls = Math.floor(next() * 43);
    const values = {
      id: i + 1,
      first,
      last,
      frames: last - first + 1,
      detected: last - first,
      clearest: last,
      class_id: cls,
      share: 0.95 - uncertainty * 0.5,
      runner_up: (cls + 1) % 43,
      runner_up_share: 0.03 + uncertainty * 0.4,
      score: 1 + next() * 8,
      side: 20 + next() * 80,
      rejected: 1,
      relocalised: 1,
      uncertainty,
      rank: uncertainty,
      reasons:
        uncertainty > 0.2
          ? [`Its class leads by ${(100 - uncertainty * 90).toFixed(0)} % of the votes only.`, `It is short: ${last - first + 1} frames.`]
          : [],
    };
    for (const [name, value] of Object.entries(values)) (tracks[name] ??= []).push(value);
    let at = first;
    while (at <= last) {
      const to = Math.min(last, at + 2 + Math.floor(next() * 40));
      lanes.track.push(i + 1);
      lanes.first.push(at);
      lanes.last.push(to);
      lanes.source.push(next() < 0.6 ? 0 : next() < 0.6 ? 1 : 2);
      at = to + 1;
    }
  }
  return { tracks, lanes };
}

/**
 * @param {any} tracks
 * @param {number} i   place in the columns
 * @param {number} [last]
 * @returns {import('../../../static/js/types.js').TrackLane}
 */
export function syntheticLane(tracks, i, last = tracks.last[i]) {
  const next = seededRandom(i + 99);
  /** @type {any} */
  const lane = { id: tracks.id[i], classes: [tracks.class_id[i], tracks.runner_up[i], 20], events: [], tau: 15, symmetry_floor: 0.6 };
  for (let frame = tracks.first[i]; frame <= last; frame += 1) {
    const step = frame - tracks.first[i];
    const symmetry = 1 + next() * 2;
    const bits = 2 + Math.floor(next() * 12);
    const place = 0.1 + next() * 1.4;
    const value = step === 0 ? null : symmetry * bits * place;
    const confident = value === null ? null : value < 15;
    const source = confident === false ? (next() < 0.6 ? 2 : 1) : next() < 0.7 ? 0 : 1;
    const a = Math.min(0.92, 0.45 + step * 0.012);
    const row = {
      frame,
      source,
      box: [10, 10, 50, 50],
      score: source === 0 ? 3 + next() * 3 : null,
      raw_score: source === 0 ? 2 + next() * 3 : null,
      prior: source === 0 ? 0.7 : null,
      l_positive: value,
      symmetry: value && symmetry,
      symmetry_magnitude: value && 1 / symmetry,
      hash_distance: value && bits,
      position_distance: value && place,
      confident,
      decision: source === 2 ? next() * 2 : null,
      probability: source === 2 ? 0.6 + next() * 0.3 : null,
      scale: 40,
      weight: step + next(),
      votes: [a, (1 - a) * 0.7, (1 - a) * 0.2],
      probabilities: [a, 0.1, 0.1],
      top: lane.classes[0],
      top_probability: a,
      learned: 1,
      unlearned: 0,
    };
    for (const [name, cell] of Object.entries(row)) (lane[name] ??= []).push(cell);
    if (source === 2)
      lane.events.push({
        frame,
        kind: 'relocalised',
        text: `Prediction of track ${lane.id} rejected, L = ${value?.toFixed(1)} > 15, symmetry ${(1 / symmetry).toFixed(2)} is low; relocalised 6 px left.`,
      });
  }
  return lane;
}
