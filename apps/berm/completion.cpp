#include "completion.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace {

// The tools' options are asked for once a shell: Python takes a second to start.
constexpr const char* script = R"bash(# Completion of berm for bash: eval "$(berm completion bash)", or into /etc/bash_completion.d/berm
_berm_files() {{
  compopt -o filenames 2>/dev/null
  mapfile -t COMPREPLY < <(compgen -d -- "$1"; [[ -z $2 ]] || compgen -f -X "!$2" -- "$1")
}}
_berm_ask() {{
  local kept=_berm_options_$2
  [[ -n ${{!kept-}} ]] || printf -v "$kept" '%s' "$("$1" "$2" --help 2>/dev/null | grep -oE -- '--[a-z][a-z-]*' | sort -u | tr '\n' ' ')"
  options=${{!kept}}
}}
_berm() {{
  local word=${{COMP_WORDS[COMP_CWORD]}} before=${{COMP_WORDS[COMP_CWORD-1]}} command=${{COMP_WORDS[1]}} options
  COMPREPLY=()
  if ((COMP_CWORD == 1)); then
    COMPREPLY=($(compgen -W "{0} --help --version" -- "$word"))
    return
  fi
  case $before in
    --restart) _berm_files "$word" '*.h5'; return;;
    --out) _berm_files "$word" ''; return;;
    --reference) _berm_files "$word" '*.csv'; return;;
    --format) COMPREPLY=($(compgen -W "markdown json" -- "$word")); return;;
    --set|-n|--jobs|--only|--title|--scale|--material|--tolerance|--most|--jump) return;;
  esac
  case $command in
{1}    *) return;;
  esac
  if [[ $word == -* ]]; then
    COMPREPLY=($(compgen -W "$options" -- "$word"))
  elif [[ $command == report ]]; then
    _berm_files "$word" ''
  elif [[ $command == completion ]]; then
    COMPREPLY=($(compgen -W bash -- "$word"))
  elif [[ $command != version && $command != schema ]]; then
    _berm_files "$word" '*.toml'
  fi
}}
complete -F _berm berm
)bash";

}  // namespace

std::string bash_completion(const std::vector<CommandWords>& commands) {
  std::vector<std::string> names;
  std::string cases;
  for (const CommandWords& c : commands) {
    names.push_back(c.name);
    cases += c.options.empty() ? fmt::format("    {0}) _berm_ask \"${{COMP_WORDS[0]}}\" {0};;\n", c.name)
                               : fmt::format("    {}) options=\"{}\";;\n", c.name, fmt::join(c.options, " "));
  }
  return fmt::format(script, fmt::join(names, " "), cases);
}
