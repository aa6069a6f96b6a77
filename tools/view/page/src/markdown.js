// The Markdown that our tools write: headings, paragraphs, lists, tables, **bold**, `code`. Everything else stays as it is.
function inline(element, text) {
  for (const part of text.split(/(\*\*[^*]+\*\*|`[^`]+`)/)) {
    if (part.startsWith('**')) {
      element.append(Object.assign(document.createElement('b'), {textContent: part.slice(2, -2)}));
    } else if (part.startsWith('`')) {
      element.append(Object.assign(document.createElement('code'), {textContent: part.slice(1, -1)}));
    } else {
      element.append(part.replaceAll('\\*', '*'));
    }
  }
  return element;
}

const make = (tag, text) => inline(document.createElement(tag), text);
const cellsOf = (line) => line.replace(/^\||\|$/g, '').split('|').map((cell) => cell.trim());

function table(lines) {
  const element = document.createElement('table');
  lines.filter((line) => !/^\|[\s:|-]+\|?$/.test(line)).forEach((line, i) => {
    const row = element.insertRow();
    for (const cell of cellsOf(line)) row.append(make(i === 0 ? 'th' : 'td', cell));
  });
  const box = document.createElement('div');
  box.className = 'wide';
  box.append(element);
  return box;
}

function block(lines) {
  const heading = lines[0].match(/^(#+) (.*)$/);
  if (heading) return make(`h${Math.min(heading[1].length, 6)}`, heading[2]);
  if (lines[0].startsWith('|')) return table(lines);
  if (lines[0].startsWith('* ')) {
    const list = document.createElement('ul');
    lines.join('\n').split(/^\* /m).slice(1).forEach((item) => list.append(make('li', item)));
    return list;
  }
  return make('p', lines.join('\n'));
}

export function renderMarkdown(text) {
  return text.split(/\n\s*\n/).map((part) => part.split('\n').filter((line) => line.trim() !== ''))
      .filter((lines) => lines.length > 0).map(block);
}
