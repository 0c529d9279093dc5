// Keeps what the server sends, and shows it. Every text comes in by textContent.
import {drawMap} from './map.js';
import {drawMargins} from './margins.js';
import {STATES, crosses, detectorLine, fresh, line, minutes, stateColour} from './style.js';

const LOST_MS = 1500, KEPT = 2500;
const WORDS = {alarm: 'alarm', suspicious: 'suspicious', degraded: 'degraded', normal: 'normal',
  not_observable: 'not observable', not_ready: 'not ready', silent: 'monitor silent',
  lost: 'no connection'};
const find = id => document.getElementById(id);
const kept = {track: [], states: [], margins: {}};
const rows = new Map();
let frame = null, heardAt = performance.now(), source = null, arrivals = [];

function listen() {
  source = new EventSource('events');
  source.onmessage = event => take(JSON.parse(event.data));
}

function take(told) {
  heardAt = performance.now();
  arrivals.push(heardAt);
  frame = told;
  if (told.reset) Object.assign(kept, {track: [], states: [], margins: {}});
  add(kept.track, told.track);
  add(kept.states, told.states);
  for (const [name, points] of Object.entries(told.margins))
    add(kept.margins[name] ??= [], points);
  document.documentElement.dataset.frames = Number(document.documentElement.dataset.frames ?? 0) + 1;
  if (!document.hidden) requestAnimationFrame(show);
}

function add(list, entries) {
  list.push(...entries);
  if (list.length > KEPT) list.splice(0, list.length - KEPT);
}

function show() {
  if (!frame) return;
  banner();
  const seen = {...kept, ...frame, track: kept.track, states: kept.states, margins: kept.margins};
  const now = frame.position;
  if (now && kept.track.length)
    seen.track = [...kept.track, [frame.time, now.east, now.north]];
  drawMap(find('map'), seen);
  drawMargins(find('margins'), seen);
  table();
  key();
}

function banner() {
  const lostMs = performance.now() - heardAt, lost = lostMs > LOST_MS;
  const state = lost ? 'lost' : frame?.state ?? 'waiting';
  document.documentElement.classList.toggle('old', lost);
  document.documentElement.classList.toggle('quiet', state === 'silent');
  if (find('banner').dataset.state !== state) find('banner').dataset.state = state;
  text('word', WORDS[state] ?? 'connecting');
  document.title = `${(WORDS[state] ?? 'connecting').toUpperCase()} · hijack_detect`;
  if (lost) {
    text('why', 'nothing comes from the viewer: is it running, and can it be reached? ' +
      (frame ? 'What is shown is old.' : ''));
    text('since', `${(lostMs / 1000).toFixed(0)} s`);
  } else if (frame) {
    text('why', state === 'silent' ? silence() : frame.why);
    text('since', since(state));
  }
  text('probability', lost || frame?.probability == null ? '–' : frame.probability.toFixed(2));
  text('clock', frame?.time == null ? '–' : minutes(frame.time));
  const at = frame?.position;
  text('position', at ? `${metres(at.east)} m East, ${metres(at.north)} m North` +
    (at.altitude == null ? '' : `, ${metres(at.altitude)} m high`) : frame?.time == null ? '' : 'no fix');
  text('utc', frame?.stamp > 1e9
    ? new Date(frame.stamp * 1000).toISOString().replace('T', ' ').slice(0, 21) + ' UTC (stamps)'
    : '');
}

function silence() {
  if (frame.silent === null) return 'no hijack_alert was heard yet: is the monitor running, in ' +
    'this ROS domain and namespace?';
  return `no hijack_alert: silence is not safety. The last that was heard is ${
    (WORDS[frame.said] ?? '').toUpperCase()}` + (frame.said === 'alarm' ? `: ${frame.why}` : '.');
}

function since(state) {
  if (state === 'silent') return frame.silent === null ? '–' : `${frame.silent.toFixed(0)} s`;
  if (frame.since == null) return '–';
  return `${minutes(frame.since)} (${Math.max(0, frame.time - frame.since).toFixed(0)} s)`;
}

function text(id, words) {
  const element = typeof id === 'string' ? find(id) : id;
  if (element.textContent !== words) element.textContent = words;
}

const metres = value => value.toFixed(0).replace('-', '−');

function table() {
  frame.detectors.forEach((one, index) => {
    const row = rows.get(one.name) ?? make(one.name);
    const state = STATES[one.state] ?? STATES.silent, cells = row.children;
    if (row.dataset.state !== one.state) {
      row.dataset.state = one.state;
      row.toggleAttribute('data-raised', ['alarm', 'suspicious'].includes(one.state));
      cells[1].dataset.sign = state.sign;
    }
    row.style.setProperty('--mark', stateColour(one.state));
    text(cells[1], state.word);
    text(cells[2], one.margin === null ? '–' : one.margin.toFixed(2));
    text(cells[3], one.why);
    swatch(cells[0].firstChild, detectorLine(index));
  });
  const list = find('complaints');
  while (list.children.length > frame.complaints.length) list.lastChild.remove();
  frame.complaints.forEach((words, index) =>
    text(list.children[index] ?? list.appendChild(document.createElement('li')), words));
}

function make(name) {
  const row = find('detectors').insertRow();
  for (let cell = 0; cell < 4; cell++) row.insertCell();
  row.children[2].className = 'n';
  row.children[0].append(document.createElement('canvas'), name);
  rows.set(name, row);
  return row;
}

function swatch(canvas, {colour, dash, width = 2.5, crosses: crossed = false}) {
  if (canvas.dataset.drawn === colour) return;
  canvas.dataset.drawn = colour;
  const {pen, width: long, height} = fresh(canvas), y = height / 2;
  line(pen, [[2, y], [long - 2, y]], colour, width, dash);
  if (crossed) crosses(pen, [[long / 2, y]], colour);
}

// The styles of the track that are in it for long enough to be seen, and the one of now.
function key() {
  const list = find('key'), ends = [...kept.states.slice(1).map(one => one[0]), Infinity];
  const seen = kept.states.filter((one, index) => ends[index] - one[0] >= 0.5);
  const states = [...new Set(seen.map(one => one[1]))];
  states.forEach((state, index) => {
    const item = list.children[index] ?? list.appendChild(document.createElement('li'));
    if (item.dataset.state !== state) {
      item.dataset.state = state;
      item.replaceChildren(document.createElement('canvas'), STATES[state]?.word ?? state);
    }
    swatch(item.firstChild, {...(STATES[state] ?? STATES.silent), colour: stateColour(state)});
  });
  while (list.children.length > states.length) list.lastChild.remove();
}

setInterval(() => {
  banner();
  const now = performance.now();
  arrivals = arrivals.filter(at => now - at < 3000);
  text('rate', `${(arrivals.length / 3).toFixed(0)} updates/s`);
  if (source.readyState === EventSource.CLOSED) listen();
}, 500);
document.addEventListener('visibilitychange', show);
addEventListener('resize', show);
listen();
