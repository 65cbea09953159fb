; Copyright 2026 The OpenFab Authors
; SPDX-License-Identifier: Apache-2.0

(comment) @comment
(string) @string
(number) @number
(boolean) @boolean

["if" "else" "switch" "case" "default"] @keyword.conditional
["for" "while" "do"] @keyword.repeat
["return"] @keyword.return
["fablet" "struct"] @keyword.type
["import"] @keyword.import
(break) @keyword.repeat
(continue) @keyword.repeat
(qualifier) @keyword.modifier
(marker) @attribute
"@" @attribute

(import module: (identifier) @module)
(fablet name: (identifier) @type.definition)
(struct name: (type_identifier) @type.definition)
(type_identifier) @type
((type_identifier) @type.builtin
  (#match? @type.builtin "^((bool|int|uint|float)([2-4](x[2-4])?)?|void|string|Material|MaterialComposition|Object|ImageTexture[23]D|DitherAttributes|SurfaceAttributes|SurfacePoint|VolumeAttributes)$"))

(function name: (identifier) @function)
(call function: (identifier) @function.call)
((call function: (identifier) @type.builtin)
  (#match? @type.builtin "^(bool|int|uint|float)([2-4](x[2-4])?)?$"))
(call function: (field member: (field_identifier) @function.method.call))
(field member: (field_identifier) @variable.member)
(parameter (declarator name: (identifier) @variable.parameter))
(varying (declarator name: (identifier) @variable.parameter))
(uniform (declarator name: (identifier) @property))
(annotation name: (identifier) @property)
(identifier) @variable

["=" "+=" "-=" "*=" "/=" "%=" "&=" "|=" "^=" "<<=" ">>=" "+" "-" "*" "/" "%" "!" "~" "++" "--" "&&" "||" "&" "|" "^"
 "==" "!=" "<" ">" "<=" ">=" "<<" ">>" "?" ":"] @operator
["(" ")" "{" "}" "[" "]" "[["] @punctuation.bracket
["," ";" "."] @punctuation.delimiter
